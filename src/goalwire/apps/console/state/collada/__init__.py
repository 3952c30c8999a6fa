"""Reads COLLADA files (.dae), and writes them as glTF, which the page's 3D library reads.

Files come from the packages of others. So a file's size, elements and triangles are limited, and each problem
is a ColladaError with one line. Why a reader of our own, and not a library: docs/adr/021-the-console.md.
"""
