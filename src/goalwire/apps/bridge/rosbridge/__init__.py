"""The rosbridge protocol, version 2: JSON or CBOR over a web socket, as roslibjs and roslibpy speak it."""
