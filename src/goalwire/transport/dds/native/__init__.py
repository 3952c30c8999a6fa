"""ROS 2 on DDS by goalwire's own RTPS session: no library, and the dialects of all vendors' services at once.

rmw              what the RMWs do otherwise where a program leaves it to them
qos              a QoS of ROS 2 in RTPS's terms, and back
context          what all endpoints of a session share: the participant, the graph, the announcement
discovery        participants and endpoints become nodes and endpoints of the graph
events           totals of what the wire tells of an endpoint: matches, deadlines, liveliness, losses
topics           publishers and subscriptions
dialects         the forms of requests and replies, by vendor: pure
ends             what clients and servers have in common
client, service  the ends of services
session          all of it together
"""
