# SPDX-License-Identifier: Apache-2.0
"""What the shots are made of: stages, materials, solids, meshes and chess pieces."""
