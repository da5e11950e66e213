"""Constants of a robot and a scene, from recordings; each with how sure it is."""
