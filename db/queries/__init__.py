"""Queries by what they are about; `db.store` puts them together."""
