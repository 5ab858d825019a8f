"""Materials of the Cycles test set: procedural textures, metal, glass, thin cloth, what glows."""
import bpy


def node_tree(owner):
    owner.use_nodes = True
    tree = owner.node_tree
    tree.nodes.clear()
    return tree


def pattern(tree, kind, scale, colours, stretch, seed):
    """Output sockets (colour, height) of a procedural texture in object space."""
    places, mapping = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeMapping")
    tree.links.new(places.outputs["Object"], mapping.inputs["Vector"])
    mapping.inputs["Scale"].default_value = stretch
    mapping.inputs["Location"].default_value = (seed * 1.37, seed * 2.11, seed * 0.73)
    node = tree.nodes.new({"brick": "ShaderNodeTexBrick", "checker": "ShaderNodeTexChecker", "noise": "ShaderNodeTexNoise",
                           "voronoi": "ShaderNodeTexVoronoi", "wood": "ShaderNodeTexWave", "rings": "ShaderNodeTexWave",
                           "marble": "ShaderNodeTexWave"}[kind])
    tree.links.new(mapping.outputs[0], node.inputs["Vector"])
    node.inputs["Scale"].default_value = scale
    if kind in ("brick", "checker"):
        for i, colour in enumerate(colours):
            node.inputs["Mortar" if i == 2 else f"Color{i + 1}"].default_value = (*colour, 1)
        return node.outputs["Color"], node.outputs["Fac"]
    if kind == "noise":
        node.inputs["Detail"].default_value, node.inputs["Roughness"].default_value = 6, 0.65
    if kind in ("wood", "marble"):
        node.inputs["Distortion"].default_value = 4 if kind == "wood" else 14
        node.inputs["Detail"].default_value, node.inputs["Detail Scale"].default_value = 4, 1.6
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    if kind in ("noise", "voronoi"):
        ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.25, 0.7
    for element, colour in zip(ramp.color_ramp.elements, colours):
        element.color = (*colour, 1)
    height = node.outputs["Distance" if kind == "voronoi" else "Fac"]
    tree.links.new(height, ramp.inputs[0])
    return ramp.outputs[0], height


def surface(colour=(0.8, 0.8, 0.8), texture=None, scale=5.0, colours=None, stretch=(1, 1, 1), bump=0.0, seed=0, picture=None,
            **inputs):
    """A principled material: one colour, a procedural texture of `colours`, or a picture by the mesh's own coordinates.

    Other arguments are inputs of the shader, such as Roughness or Coat_Weight.
    """
    made = bpy.data.materials.new("surface")
    tree = node_tree(made)
    shader, output = tree.nodes.new("ShaderNodeBsdfPrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    shader.inputs["Base Color"].default_value = (*colour, 1)
    for name, value in inputs.items():
        shader.inputs[name.replace("_", " ")].default_value = value
    if picture:
        image = tree.nodes.new("ShaderNodeTexImage")
        image.image = bpy.data.images.load(str(picture), check_existing=True)
        tree.links.new(image.outputs["Color"], shader.inputs["Base Color"])
    if texture:
        shade, height = pattern(tree, texture, scale, colours, stretch, seed)
        tree.links.new(shade, shader.inputs["Base Color"])
        if bump:
            bumps = tree.nodes.new("ShaderNodeBump")
            bumps.inputs["Strength"].default_value, bumps.inputs["Distance"].default_value = abs(bump), 0.05
            bumps.invert = bump < 0
            tree.links.new(height, bumps.inputs["Height"])
            tree.links.new(bumps.outputs[0], shader.inputs["Normal"])
    return made


def metal(colour, roughness, **inputs):
    return surface(colour, Metallic=1.0, Roughness=roughness, **inputs)


def glass(colour=(1, 1, 1), roughness=0.0, ior=1.5, absorbs=None, density=1.0):
    """absorbs: the colour that is left of white light inside, at a depth of about 1 / density."""
    made = bpy.data.materials.new("glass")
    tree = node_tree(made)
    shader, output = tree.nodes.new("ShaderNodeBsdfGlass"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value, shader.inputs["IOR"].default_value = roughness, ior
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    if absorbs:
        inside = tree.nodes.new("ShaderNodeVolumeAbsorption")
        inside.inputs["Color"].default_value, inside.inputs["Density"].default_value = (*absorbs, 1), density
        tree.links.new(inside.outputs[0], output.inputs["Volume"])
    return made


def thin_cloth(colour, through=0.5):
    """A lamp shade, a leaf, a curtain: diffuse on both sides."""
    made = bpy.data.materials.new("cloth")
    tree = node_tree(made)
    front, back, both = (tree.nodes.new("ShaderNode" + name) for name in ("BsdfDiffuse", "BsdfTranslucent", "MixShader"))
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    front.inputs["Color"].default_value = back.inputs["Color"].default_value = (*colour, 1)
    both.inputs[0].default_value = through
    tree.links.new(front.outputs[0], both.inputs[1])
    tree.links.new(back.outputs[0], both.inputs[2])
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    return made


def glowing(colour, strength):
    return surface((0, 0, 0), Emission_Color=(*colour, 1), Emission_Strength=strength)
