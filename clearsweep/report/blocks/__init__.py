"""The blocks of sections: sentences, tables, pictures and interactive parts, and how each is written."""
