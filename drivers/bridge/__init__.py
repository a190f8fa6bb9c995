"""The bridge: from a source of readings through a durable spool to a service."""
