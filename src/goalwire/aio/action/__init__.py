"""Actions in the asyncio API."""
