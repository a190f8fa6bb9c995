"""What the product does: plain functions over a unit of work and a clock."""
