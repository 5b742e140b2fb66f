"""friction"""
