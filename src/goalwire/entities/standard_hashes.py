"""Hashes of the types that every node has, written by tools/generate.py; do not edit."""

SERVICES = {
    'lifecycle_msgs/srv/ChangeState': (
        'RIHS01_356fe34f0475a43acf54542013af4167b0e729f77ea22ffb045c6ad8e20668e5',
        'RIHS01_d74c6f524e14cade7b67e7297190360ed749264af300524fc1456f27cc2a553a',
        'RIHS01_e1ddfed0271fefe63767aa71561926e4d9eac0f1ddf9e71a8873eb46b36deac2',
    ),
    'lifecycle_msgs/srv/GetAvailableStates': (
        'RIHS01_00a07d79d2207d71e81a8cbc1880e5d924cc16d4688ea8e8e06e443dc8f8aa1d',
        'RIHS01_c2c0c12de6023822f284929577d4ca2862e0501150010966e8a90b632e4424de',
        'RIHS01_223e0dd5bb8a847ebb9532adaf8b5e2a97e6e68e79faeaabd81a45fb32925bd1',
    ),
    'lifecycle_msgs/srv/GetAvailableTransitions': (
        'RIHS01_59b7ecefce0982a8a844b9f2c4f14764c1c4543cc55e72924e2aa4adad83e9bc',
        'RIHS01_52a73c0b5d7489bee0df6ddb0aec45c41289d223ff225b58fe11d859ac8109a6',
        'RIHS01_4711339461aadf02bcfff797a198de911f885074bd3f2fe9f7b677ef87f0741c',
    ),
    'lifecycle_msgs/srv/GetState': (
        'RIHS01_800a0a5aae599782b02932de0caf563f6dc4e7e94b794eadde075ba2cbef9795',
        'RIHS01_77a9c844e7975f15bc2221e8bbebafc4d118afb78c7f7071eef91f83f940f2f6',
        'RIHS01_fe249babab472e42cb5653b5d6a6b0c42a003b0fdfb84851aea3fde08760b4f5',
    ),
    'rcl_interfaces/srv/DescribeParameters': (
        'RIHS01_845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff',
        'RIHS01_05dd1c2bc87dec2627105c8070d6f9725c781a4f2ab852975bf105462b82b644',
        'RIHS01_ad6747319613c6131589e062e095b469a46cc764f7d0f12a001a49e6cd893995',
    ),
    'rcl_interfaces/srv/GetLoggerLevels': (
        'RIHS01_03bf1bebd0d6514c7ed0ba7c5e08dc9f2f39c759fe99e1e30ea4157d7674f72d',
        'RIHS01_490ace424a5f5b14cb4e1e95030d7fe366d8df0fd9fe4d03b44d6009504fd2cc',
        'RIHS01_228685d350911d213047abe756f5bf566d2f76b359c4e9fac16e5ef652aff910',
    ),
    'rcl_interfaces/srv/GetParameterTypes': (
        'RIHS01_da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca',
        'RIHS01_87d7ec5ef545d4daa289d500025d31fb2437bc8b8365ca367161c4dac4be33fd',
        'RIHS01_ac1335dce67c478e669434f6ac2fbff34fcd529580f272d3006785ba8b54e47f',
    ),
    'rcl_interfaces/srv/GetParameters': (
        'RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc',
        'RIHS01_135a9e1c3d7cebef792f6687d7ddf99949b21a0bd9a320d863a9110a3f5cf4d6',
        'RIHS01_9fa773b46e39cc5d02db6224d8fd520bb9caeeffc2b27c96c1e59431baba9f2a',
    ),
    'rcl_interfaces/srv/ListParameters': (
        'RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d',
        'RIHS01_a1b0b5d6b967a5b8ac5bc8563c3ea678f349e312a6a4967227c5a96bc5ce38df',
        'RIHS01_31b937b82de3612426be79f231e386259f97e8dc843e3f2845288b4bfa296bdd',
    ),
    'rcl_interfaces/srv/SetLoggerLevels': (
        'RIHS01_3ff86cb4e91fbf9abae15c234ecc874448de6ece8e193401c077cf116e4f6d78',
        'RIHS01_4e7768e0f4c749205f35bc05449f83fad18c42de52c16b1934d66c2f68ffd862',
        'RIHS01_ba51739027e57cb9120015737f4618579684047d862b2b16a76bc399d987d6d3',
    ),
    'rcl_interfaces/srv/SetParameters': (
        'RIHS01_56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0',
        'RIHS01_130d46386b7e84ea9ecf60608a4d83cbe5e5cb7c6cc5b712b7a4e3a6c254e932',
        'RIHS01_7a0e8140a0b8d98308fa81a5403a766e610af29a239caf54b7553227906fc266',
    ),
    'rcl_interfaces/srv/SetParametersAtomically': (
        'RIHS01_0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd',
        'RIHS01_db0bd950ed5ed867a0e90b225e44dea382d762c0762ff3e0ee842190042a59e5',
        'RIHS01_31b1a38c5b0b9d893ee24da45f69638f4561c78461d82d52750f429b534502b8',
    ),
    'type_description_interfaces/srv/GetTypeDescription': (
        'RIHS01_69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5',
        'RIHS01_470f56ccbcf13d55c78c8b735fb12da03e639e5acded994426c89d94778d9e28',
        'RIHS01_648c49d976240861a482f961c5621ddd0d2135d8cce6f297a76d4f6376d93b75',
    ),
}
"""Of each service: its hash, and those of its request and its response."""

MESSAGES = {
    'lifecycle_msgs/msg/TransitionEvent': (
        'RIHS01_d5f8873a2f0146498f812d7885c7327ce27e463d36811d8792f35ee38c0d6c38',
        False,
    ),
    'rcl_interfaces/msg/Log': (
        'RIHS01_e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac',
        False,
    ),
    'rcl_interfaces/msg/ParameterEvent': (
        'RIHS01_043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204',
        True,
    ),
}
"""Of each message: its hash, and whether a field of it holds a buffer."""
