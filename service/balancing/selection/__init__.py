"""The discrete problem: which stock masses go into which positions."""
