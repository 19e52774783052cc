"""YAML and JSON files: read strictly and checked by the schemas of config/schemas, with a clear error message.

May import: common.
"""
