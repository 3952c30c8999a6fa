"""A simulated fleet below sites and a cloud: python -m benchmarks.fleet.

programs     what runs: robots, an operator, a sender of goals
layout       the keystore, the routers, the robots of one run
slow_links   a relay: late, narrow, with stalls, breaks and partitions
chaos        kills and partitions routers at random while goals and calls go on
books        what was sent, how it ended, and what the robots have run
__main__     what is measured and printed
"""
