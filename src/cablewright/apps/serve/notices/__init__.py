"""News of a print for other programs: layer, pause, fault and end, by webhooks and MQTT."""
