"""Boxes of stock masses and their ledger."""
