"""Parameters of UltrasonicSensor for real devices: `scene.add("UltrasonicSensor", "ears", **ulna.devices["HC-SR04"])`.

What a sheet does not say stays at the unit's default: above all the threshold, which differs from one specimen to the
next, and but for the PING))) the latency, of which users measure some milliseconds. The unit's own conversion, 58
us/cm, is that of all four (MaxBotix: 147 us/inch, 57.9 us/cm).

Sources: HC-SR04, data sheet of Elec Freaks (range, resolution, 8 periods of 40 kHz, a ping every 60 ms or more) and
sellers' sheets (the line falls after 38 ms); SRF04, Devantech's technical documentation (3 cm to 3 m, 8 periods, 36 ms,
a trigger every 50 ms); PING))) #28015, Parallax, v2.0 of 2013 (2 cm to 3 m, 200 us of 40 kHz, 18.5 ms, the line rises
750 us after the trigger); LV-MaxSonar-EZ1 MB1010, MaxBotix (one transducer, 6 to 254 inches by 1 inch, 13 periods of 42
kHz, 20 pings a second).
"""

devices: dict[str, dict[str, float]] = {
    "HC-SR04": {
        "frequency": 40000.0,
        "burst_periods": 8.0,
        "baseline": 0.026,
        "minimum_range": 0.02,
        "maximum_range": 4.0,
        "resolution": 0.003,
        "period": 0.06,
        "time_out": 0.038,
    },
    "SRF04": {
        "frequency": 40000.0,
        "burst_periods": 8.0,
        "minimum_range": 0.03,
        "maximum_range": 3.0,
        "resolution": 0.0,
        "period": 0.05,
        "time_out": 0.036,
    },
    "Parallax PING": {
        "frequency": 40000.0,
        "burst_periods": 8.0,
        "minimum_range": 0.02,
        "maximum_range": 3.0,
        "resolution": 0.0,
        "time_out": 0.0185,
        "trigger_latency": 750e-6,
    },
    "MaxBotix LV-EZ1": {
        "frequency": 42000.0,
        "burst_periods": 13.0,
        "baseline": 0.0,
        "minimum_range": 0.1524,
        "maximum_range": 6.45,
        "resolution": 0.0254,
        "period": 0.05,
    },
}
