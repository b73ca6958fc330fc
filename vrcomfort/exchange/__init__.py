"""Study folders between labs: verified, overseen, made anonymous, exported."""
