"""ROS 2 on DDS by goalwire's own RTPS session: no library, and the dialects of all vendors' services at once.

rmw              the defaults of the RMWs, for policies that a program leaves open
qos              a QoS of ROS 2 in RTPS's terms, and back
context          what all endpoints of a session share: the participant, the graph, the announcement
discovery        turns participants and endpoints into nodes and endpoints of the graph
events           totals of an endpoint's events: matches, deadlines, liveliness, losses
topics           publishers and subscriptions
dialects         the forms of requests and replies, by vendor: pure
service_ends     the common part of clients and servers: their readers and writers
replies          the reader that takes the replies of one service for all clients
client, service  service clients and servers
session          sessions, made of all this
"""
