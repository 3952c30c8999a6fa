"""python read_lerobot.py FOLDER: reads a dataset with lerobot's own class, and prints its content as JSON."""

import json
import sys
from pathlib import Path

from lerobot.datasets.lerobot_dataset import LeRobotDataset

folder = Path(sys.argv[1])
# PyAV brings FFmpeg along; torchcodec, the default, needs that of the system.
dataset = LeRobotDataset(folder.name, root=folder, video_backend='pyav')
frames = []
for number in range(len(dataset)):
    item = dataset[number]
    frames.append(
        {
            'episode': int(item['episode_index']),
            'time': float(item['timestamp']),
            'task': item['task'],
            'state': item['observation.state'].tolist(),
            'action': item['action'].reshape(-1).tolist(),  # one number alone has no dimension
            'pixels': {
                key: (item[key] * 255).round().int().permute(1, 2, 0).tolist()
                for key in dataset.meta.camera_keys
            },
        }
    )
features = {
    key: {'names': value['names'], 'dtype': value['dtype']} for key, value in dataset.meta.features.items()
}
print(
    json.dumps(
        {
            'frames': frames,
            'features': features,
            'fps': dataset.fps,
            'episodes': dataset.num_episodes,
            'robot': dataset.meta.robot_type,
        }
    )
)
