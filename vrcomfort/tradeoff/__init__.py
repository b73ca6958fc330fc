"""What each way of blurring costs and how wrong it is, measured against two references."""
