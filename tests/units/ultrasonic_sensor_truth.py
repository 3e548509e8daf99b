"""What echoes and comparator do by wave theory: models/ultrasonic_sensor, for the tests."""

from ulna.checks.textbook import load_model

PARTS = ("hearing", "echoes", "surfaces", "meshes")
hearing, echoes, surfaces, meshes = (load_model(f"ultrasonic_sensor.{part}") for part in PARTS)
Agreement, Device = hearing.Agreement, hearing.Device
image_source, rigid_sphere, kirchhoff = echoes.image_source, echoes.rigid_sphere, echoes.kirchhoff
box_surface, capsule_surface = surfaces.box_surface, surfaces.capsule_surface
rectangle_surface = surfaces.rectangle_surface
Mesh, capsule_mesh, plate_mesh, joined = meshes.Mesh, meshes.capsule_mesh, meshes.plate_mesh, meshes.joined
