"""Where the platform is, from what its sensors say."""
