"""Where the platform can be: criteria, volumes, surfaces and retraction."""
