"""Bags as Parquet, pictures and datasets of LeRobot. `bag export` writes CSV and JSON lines itself."""
