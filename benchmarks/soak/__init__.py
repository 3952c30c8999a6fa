"""An hour of mixed load with processes killed all the time: is every call accounted for in the end?"""
