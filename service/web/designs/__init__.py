"""What pages, report and command of design studies share: names, forms, tables, figures."""
