"""YAML and JSON documents: read strictly, checked by the schemas of config/schemas, with one clear error."""
