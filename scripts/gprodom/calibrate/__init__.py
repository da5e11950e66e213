"""Constants of a robot and a scene, estimated from recordings, each with its standard deviation."""
