"""Signing in with a token at a console or a bridge: the tokens, and what the policy allows to whom.

tokens      the file with the tokens, as hashes
authorizer  finds out whose token was shown, asks the policy, and writes the audit log
signed_in   one person or program that has signed in
"""
