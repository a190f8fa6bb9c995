"""Storage: rows, JSON documents, repositories, unit of work, migrations."""
