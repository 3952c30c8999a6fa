"""Who is who, and who may do what: keystores and policies. Nothing here knows a transport."""
