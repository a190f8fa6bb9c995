"""Tests of service.messages."""
