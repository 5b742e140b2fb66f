"""A whole arm, its hand guided by a person or its joints by its own motors."""
