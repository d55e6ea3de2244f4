"""Surface roughness of a joint, in series with its elastic law; one block per law."""
