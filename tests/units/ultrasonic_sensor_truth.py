"""What echoes and comparator do by wave theory: models/ultrasonic_sensor, for the tests."""

from ulna.checks.textbook import load_model

hearing, echoes, surfaces = (load_model(f"ultrasonic_sensor.{part}") for part in ("hearing", "echoes", "surfaces"))
Agreement, Device = hearing.Agreement, hearing.Device
image_source, rigid_sphere, kirchhoff = echoes.image_source, echoes.rigid_sphere, echoes.kirchhoff
box_surface, capsule_surface = surfaces.box_surface, surfaces.capsule_surface
