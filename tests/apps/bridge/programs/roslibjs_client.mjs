// roslibjs, unmodified, does what pages do with it. Its argument is the bridge's address.
import * as ROSLIB from 'roslib';

const ros = new ROSLIB.Ros({url: process.argv[2]});
const fail = error => { console.log('failed', error); process.exit(1); };
const answer = start => new Promise(done => start(done, fail));

await answer(done => { ros.on('error', fail); ros.on('connection', done); });
console.log('topics', (await answer((done, failed) => ros.getTopics(done, failed))).topics.includes('/picture'));
console.log('actions', await answer((done, failed) => ros.getActionServers(done, failed)));

const speed = new ROSLIB.Param({ros, name: '/robot:speed'});
console.log('parameter', await answer(done => speed.get(done)));

const said = new ROSLIB.Topic({ros, name: '/say', messageType: 'std_msgs/String'});
said.advertise();
for (const compression of ['none', 'cbor', 'png']) {
  const pictures = new ROSLIB.Topic({ros, name: '/picture', messageType: 'sensor_msgs/Image', compression});
  const picture = await answer(done => {
    // Discovery of the two takes a moment: it speaks until a picture comes.
    const again = setInterval(() => said.publish({data: 'roslibjs'}), 100);
    pictures.subscribe(message => { clearInterval(again); pictures.unsubscribe(); done(message); });
  });
  console.log('picture', compression, picture.encoding, picture.width);
}

const add = new ROSLIB.Service({ros, name: '/add', serviceType: 'example_interfaces/AddTwoInts'});
console.log('sum', (await answer((done, failed) => add.callService({a: 1, b: 2}, done, failed))).sum);

const fibonacci = new ROSLIB.Action({ros, name: '/fibonacci', actionType: 'example_interfaces/action/Fibonacci'});
let feedbacks = 0;
const result = await answer((done, failed) =>
  fibonacci.sendGoal({order: 4}, done, () => { feedbacks += 1; }, failed));
console.log('result', result.sequence, 'after', feedbacks);

const cancelled = await new Promise(done => {
  const id = fibonacci.sendGoal({order: 1000}, () => done('it succeeded'), () => fibonacci.cancelGoal(id), done);
});
console.log('cancelled:', String(cancelled));
ros.close();
