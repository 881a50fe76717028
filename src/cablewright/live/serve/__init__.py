"""A machine that people watch and operate from a page: its control process, and the messages between both."""
