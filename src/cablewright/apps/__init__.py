"""What people meet: commands, reports, views. Everything below returns values; here they are shown."""
