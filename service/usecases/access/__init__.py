"""Who may do what: tokens, logins of browsers, throttling of failed attempts."""
