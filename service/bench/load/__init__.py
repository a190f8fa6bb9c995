"""`drumtrue bench load`: readings and plans over HTTP on both engines."""
