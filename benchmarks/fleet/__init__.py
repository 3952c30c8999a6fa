"""A simulated fleet below sites and a cloud: python -m benchmarks.fleet.

programs     what runs: robots, an operator, a sender of goals
layout       the keystore, the routers, the robots of one run
slow_links   a relay: late, narrow, with stalls and breaks
__main__     what is measured and printed
"""
