"""What sections consist of: sentences, tables, pictures, interactive parts; how each is written."""
