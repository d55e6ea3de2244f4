"""Pictures of one case: its mechanism, motion, wear; and the data of the player."""
