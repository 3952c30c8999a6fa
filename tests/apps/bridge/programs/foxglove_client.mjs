// The reference client of Foxglove's protocol, unmodified. Its argument is the bridge's address.
import protocol from '@foxglove/ws-protocol';
import rosmsg from '@foxglove/rosmsg';
import serialization from '@foxglove/rosmsg2-serialization';
import WebSocket from 'ws';

const {FoxgloveClient} = protocol;
const {MessageReader, MessageWriter} = serialization;
const parsed = text => rosmsg.parse(text, {ros2: true});
const view = bytes => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

const client = new FoxgloveClient({
  ws: new WebSocket(process.argv[2], [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});
const channels = new Map(), services = new Map();
let changed = () => {};
client.on('advertise', list => { list.forEach(each => channels.set(each.topic, each)); changed(); });
client.on('advertiseServices', list => { list.forEach(each => services.set(each.name, each)); changed(); });
client.on('error', error => { console.log('failed', error); process.exit(1); });
client.on('serviceCallFailure', error => { console.log('failed', error); process.exit(1); });

/** Resolve with a channel or service as soon as the bridge has told it. */
async function known(names, name) {
  while (!names.has(name)) await new Promise(done => { changed = done; });
  return names.get(name);
}

/** Resolve with the next message of a topic. */
async function next(topic) {
  const channel = await known(channels, topic);
  return await new Promise(done => {
    const number = client.subscribe(channel.id);
    client.on('message', function take(message) {
      if (message.subscriptionId !== number) return;
      client.off('message', take);
      client.unsubscribe(number);
      done(new MessageReader(parsed(channel.schema)).readMessage(message.data));
    });
  });
}

let calls = 0;
async function call(name, request) {
  const service = await known(services, name);
  const callId = ++calls;
  return await new Promise(done => {
    client.on('serviceCallResponse', function take(response) {
      if (response.callId !== callId) return;
      client.off('serviceCallResponse', take);
      done(new MessageReader(parsed(service.response.schema)).readMessage(view(response.data)));
    });
    const data = new MessageWriter(parsed(service.request.schema)).writeMessage(request);
    client.sendServiceCallRequest({serviceId: service.id, callId, encoding: 'cdr', data: view(data)});
  });
}

console.log('latched', (await next('/robot_description')).data);
console.log('sum', Number((await call('/add', {a: 1n, b: 2n})).sum));

const uuid = first => Uint8Array.from({length: 16}, (_, at) => first + at);
const goal = async (first, order) =>
  (await call('/fibonacci/_action/send_goal', {goal_id: {uuid: uuid(first)}, goal: {order}})).accepted;
const result = first => call('/fibonacci/_action/get_result', {goal_id: {uuid: uuid(first)}});
console.log('accepted', await goal(1, 4));
const ended = await result(1);
console.log('result', ended.status, Array.from(ended.result.sequence));

console.log('accepted', await goal(50, 1000));
console.log('feedback', (await next('/fibonacci/_action/feedback')).feedback.sequence.length > 1);
const stamp = {sec: 0, nanosec: 0};
await call('/fibonacci/_action/cancel_goal', {goal_info: {goal_id: {uuid: uuid(50)}, stamp}});
console.log('cancelled', (await result(50)).status);

const values = new Promise(done => client.on('parameterValues', done));
client.getParameters(['/robot.speed'], 'speed');
console.log('parameter', (await values).parameters[0].value);
client.close();
