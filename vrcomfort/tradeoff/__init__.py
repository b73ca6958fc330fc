"""Trade-off of cost and error of blur methods, measured against two references."""
