"""First causes of failed episodes, as recorded, and single changes that help against them."""
