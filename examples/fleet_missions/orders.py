"""Order missions, or see how they stand.

python orders.py postgresql://… order SKILL FIRST LAST
python orders.py postgresql://… show

An order whose number is known begins nothing, so this may be repeated.
"""

import sys
from collections import Counter

from dbos import DBOSClient


def main():
    url, command, *arguments = sys.argv[1:]
    client = DBOSClient(system_database_url=url)
    if command == 'order':
        skill, first, last = arguments[0], int(arguments[1]), int(arguments[2])
        for number in range(first, last):
            mission = f'order-{number}'
            options = {
                'workflow_name': 'deliver',
                'queue_name': skill,
                'workflow_id': mission,
                'app_version': '1',
            }
            client.enqueue(options, mission, skill, number)
        print(f'{last - first} missions are ordered')
    else:
        missions = client.list_workflows(name='deliver', load_output=True)
        for state, count in sorted(Counter(each.status for each in missions).items()):
            print(state, count)
    client.destroy()


if __name__ == '__main__':
    main()
