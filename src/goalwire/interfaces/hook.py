"""The import hook that serves interface packages (std_msgs, …) from their definition files."""


def install() -> None:
    """Insert the finder before the path finder; called by goalwire.pth at interpreter start."""
