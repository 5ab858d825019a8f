"""Layered Denoiser: renders the frame or the animation sample by sample with Cycles and denoises it with ld_denoise.

Panel: Properties > Render > Layered Denoiser. Without a window:

    blender -b FILE.blend --command layered_denoise --output //denoised_####.exr [--samples 8] [--frames 1:25] [--model common]
"""
import argparse
import shutil
import sys
from pathlib import Path

import bpy

from . import job


class LayeredDenoiserPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(name="Program", subtype="FILE_PATH", description="ld_denoise; empty: that of the search path")

    def draw(self, _context):
        self.layout.prop(self, "program")


class LayeredDenoiserSettings(bpy.types.PropertyGroup):
    samples: bpy.props.IntProperty(name="Samples", default=8, min=1, max=64, description="Samples a pixel, rendered one by one")
    model: bpy.props.StringProperty(name="Model", default="common", description="Released weights by name, or a file of weights")
    output: bpy.props.StringProperty(name="Output", default="//denoised_####.exr", subtype="FILE_PATH",
                                     description="OpenEXR file; # stands for a digit of the frame's number")
    threads: bpy.props.IntProperty(name="Threads", default=0, min=0, max=1024, description="Of the denoiser; 0: all processors")


def program_of(context):
    addon = context.preferences.addons.get(__package__)
    return job.find_program(bpy.path.abspath(addon.preferences.program) if addon else "")


def settings_of(context, animation):
    scene, own = context.scene, context.scene.layered_denoiser
    frames = range(scene.frame_start, scene.frame_end + 1, scene.frame_step) if animation else [scene.frame_current]
    if own.output.startswith("//") and not bpy.data.filepath:
        raise RuntimeError("save the scene first: the output's // stands for its folder")
    return job.Settings(program_of(context), own.model, own.samples, frames, bpy.path.abspath(own.output), own.threads,
                        scene.cycles.seed)


def show(name, path):
    """The picture as an image of this name that outlives its file."""
    if name in bpy.data.images:
        bpy.data.images.remove(bpy.data.images[name])
    image = bpy.data.images.load(str(path))
    image.name = name
    image.pack()
    return image


class LAYERED_DENOISER_OT_render(bpy.types.Operator):
    bl_idname = "layered_denoiser.render"
    bl_label = "Render and Denoise"
    bl_description = "Render sample by sample and denoise. Escape ends it; pictures that are finished stay"

    animation: bpy.props.BoolProperty(name="Animation", default=False, options={"SKIP_SAVE"})

    def begin(self, context):
        try:
            self.steps = job.run(context.scene, context.view_layer, settings_of(context, self.animation))
        except RuntimeError as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def step(self):
        """Whether there is more to do."""
        try:
            self.share, self.text, picture, noisy = next(self.steps)
        except StopIteration:
            return False
        if picture:
            show("Denoised", picture)
            show("Noisy", noisy)
            self.report({"INFO"}, f"{picture} written")
        return True

    def execute(self, context):  # without a window: all at once
        if not self.begin(context):
            return {"CANCELLED"}
        try:
            while self.step():
                pass
        except RuntimeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            self.steps.close()
        return {"FINISHED"}

    def invoke(self, context, _event):
        if not self.begin(context):
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.progress_begin(0, 1)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.report({"WARNING"}, "cancelled; pictures that are finished stay")
            return self.end(context, "CANCELLED")
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            if not self.step():
                return self.end(context, "FINISHED")
        except RuntimeError as error:
            self.report({"ERROR"}, str(error))
            return self.end(context, "CANCELLED")
        context.window_manager.progress_update(self.share)
        context.workspace.status_text_set(f"Layered Denoiser: {self.text} ({self.share:.0%}); Escape cancels")
        return {"RUNNING_MODAL"}

    def end(self, context, result):
        self.steps.close()
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        for area in context.screen.areas:
            if area.type == "IMAGE_EDITOR" and "Denoised" in bpy.data.images:
                area.spaces.active.image = bpy.data.images["Denoised"]
        return {result}


class LAYERED_DENOISER_PT_panel(bpy.types.Panel):
    bl_label = "Layered Denoiser"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, own = self.layout, context.scene.layered_denoiser
        layout.use_property_split = True
        for name in ("samples", "model", "output", "threads"):
            layout.prop(own, name)
        row = layout.row()
        row.operator(LAYERED_DENOISER_OT_render.bl_idname, text="Image")
        row.operator(LAYERED_DENOISER_OT_render.bl_idname, text="Animation").animation = True
        for name in ("Noisy", "Denoised"):
            if name in bpy.data.images:
                layout.label(text=f"{name}: in the Image Editor", icon="IMAGE_DATA")


def parse_frames(text):
    """"5" or "1:25", which means frames 1 to 24 as everywhere in this project."""
    first, colon, last = text.partition(":")
    return [int(first)] if not colon else list(range(int(first), int(last)))


def command(arguments):
    """blender -b FILE.blend --command layered_denoise ...; the exit code."""
    parser = argparse.ArgumentParser(prog="layered_denoise", description=__doc__.splitlines()[0])
    parser.add_argument("--output", required=True, help="OpenEXR file; # stands for a digit of the frame's number")
    parser.add_argument("--samples", type=int, default=8, help="samples a pixel (default: 8)")
    parser.add_argument("--frames", type=parse_frames, help="5, or A:B for frames A to B - 1 (default: the present frame)")
    parser.add_argument("--model", default="common", help="released weights by name, or a file of weights (default: common)")
    parser.add_argument("--program", default="", help="ld_denoise (default: of the preferences, else of the search path)")
    parser.add_argument("--noisy", type=Path, help="also write the mean of the last frame's samples here")
    parser.add_argument("--threads", type=int, default=0, help="of the denoiser (default: all processors)")
    options = parser.parse_args(arguments)
    scene = bpy.context.scene
    try:
        program = job.find_program(options.program) if options.program else program_of(bpy.context)
        settings = job.Settings(program, options.model, options.samples, options.frames or [scene.frame_current],
                                bpy.path.abspath(options.output), options.threads, scene.cycles.seed)
        for _share, _text, picture, noisy in job.run(scene, bpy.context.view_layer, settings):
            if picture:
                print(f"layered_denoise: {picture} written", flush=True)
                if options.noisy:
                    shutil.copyfile(noisy, options.noisy)
    except RuntimeError as error:
        print(f"layered_denoise: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("layered_denoise: interrupted; pictures that are finished stay", file=sys.stderr)
        return 130
    return 0


CLASSES = (LayeredDenoiserPreferences, LayeredDenoiserSettings, LAYERED_DENOISER_OT_render, LAYERED_DENOISER_PT_panel)
commands = []


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.layered_denoiser = bpy.props.PointerProperty(type=LayeredDenoiserSettings)
    commands.append(bpy.utils.register_cli_command("layered_denoise", command))


def unregister():
    bpy.utils.unregister_cli_command(commands.pop())
    del bpy.types.Scene.layered_denoiser
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
