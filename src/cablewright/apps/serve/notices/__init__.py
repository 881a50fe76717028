"""News for other programs: layer, pause, fault and end of a print, by webhooks and MQTT."""
