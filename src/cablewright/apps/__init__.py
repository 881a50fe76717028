"""User interfaces: commands, reports, pictures, views (rank 5). Lower ranks return values; here they are shown."""
