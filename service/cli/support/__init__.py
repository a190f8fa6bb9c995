"""What commands share: options, files, the HTTP client, tables on the terminal."""
