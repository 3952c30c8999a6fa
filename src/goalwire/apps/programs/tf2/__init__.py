"""Programs for transforms: packages `tf2_ros` and `tf2_tools`."""
