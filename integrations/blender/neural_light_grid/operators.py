"""Bake, Preview, Relight, Check, View and Cancel."""

import atexit
import contextlib
import json
import os
import shutil
import tempfile
from pathlib import Path

import bpy
from bpy.app.handlers import persistent
from bpy.types import Operator

from . import command, overlay, settings
from .errors import ToolError
from .export import export_scene
from .job import Job

TIMER_S = 0.2
CHECK_FAILED = 6  # of the tools' exit codes


class State:
    job = None    # at work, or None
    shown = None  # the grid whose probes are shown
    said = []     # what the last tool said, a line each


state = State()


def folder():
    """Blender removes it when it ends."""
    return os.path.join(bpy.app.tempdir, "nlg")


def stop():
    if state.job is not None:
        state.job.cancel()
        state.job.wait()
        state.job = None


@persistent
def forget(_):
    """Of another file nothing is known."""
    state.shown, state.said = None, []
    overlay.hide()


def remove(path):
    with contextlib.suppress(FileNotFoundError):
        os.remove(path)


class ToolOperator(Operator):
    """An operator that exports the scene and runs tools on it: at once where it is called by a script, in the background where it is invoked."""
    @classmethod
    def poll(cls, context):
        return state.job is None

    def commands(self, context, exported):
        """commands   the command lines"""
        raise NotImplementedError

    def finish(self, context, job):
        """What follows when they are done."""
        raise NotImplementedError

    def clean_up(self):
        """What follows in any case."""

    def start(self, context):
        state.said = []
        exported = export_scene(context, folder())
        state.job = Job(self.commands(context, exported), exported.folder)
        state.said += exported.notes
        for note in exported.notes:
            self.report({"WARNING"}, note)  # which a script sees, too

    def refuse(self, error):
        self.clean_up()
        state.said = [*state.said, str(error)]
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def end(self, context):
        job, state.job = state.job, None
        state.said = [*state.said, *job.notes]
        for note in job.notes:
            self.report({"INFO"}, note)  # which a script sees, too
        try:
            if job.is_cancelled:
                self.report({"INFO"}, f"{self.bl_label}: cancelled")
                return {"CANCELLED"}
            self.finish(context, job)
        except ToolError as error:
            return self.refuse(error)
        except OSError as error:
            return self.refuse(f"{error.filename}: {error.strerror}")
        finally:
            self.clean_up()
            overlay.redraw()
        return {"FINISHED"}

    def execute(self, context):
        try:
            self.start(context)
        except ToolError as error:
            return self.refuse(error)
        state.job.wait()
        return self.end(context)

    def invoke(self, context, event):
        try:
            self.start(context)
        except ToolError as error:
            return self.refuse(error)
        manager = context.window_manager
        self.timer = manager.event_timer_add(TIMER_S, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if state.job is None:  # stopped: the add-on is disabled
            self.cancel(context)
            return {"CANCELLED"}
        context.window_manager.nlg_progress = state.job.percent
        overlay.redraw()
        if state.job.is_running:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        return self.end(context)

    def cancel(self, context):
        """Blender ends it: another file is opened, or the window closed."""
        context.window_manager.event_timer_remove(self.timer)
        stop()
        self.clean_up()


class GridOperator(ToolOperator):
    """Makes a grid, and shows its probes."""
    made = None

    def finish(self, context, job):
        job.check()
        self.keep()
        state.shown = self.grid
        overlay.show(job.output, settings.metres_per_unit(context.scene))
        name = os.path.basename(self.grid)
        state.said = [words.replace(self.made, name).replace(self.grid, name) for words in state.said]
        self.report({"INFO"}, next((words for words in state.said if words.startswith(name)), name))

    def keep(self):
        """made becomes grid"""


class NLG_OT_bake(GridOperator):
    bl_idname = "nlg.bake"
    bl_label = "Bake"
    bl_description = "Bake the scene into its light grid"

    def commands(self, context, exported):
        self.grid = self.made = settings.grid_path(context.scene)
        return [command.bake(context, exported, self.made), command.probes(context, self.made)]


class NLG_OT_preview(GridOperator):
    bl_idname = "nlg.preview"
    bl_label = "Preview"
    bl_description = "Show what a bake would give, roughly: no fits, and few rays. The scene's light grid stays as it is"

    def commands(self, context, exported):
        self.grid = self.made = os.path.join(exported.folder, f"{settings.scene_name()}.preview.safetensors")
        return [[*command.bake(context, exported, self.made), *command.PREVIEW], command.probes(context, self.made)]


class NLG_OT_relight(GridOperator):
    bl_idname = "nlg.relight"
    bl_label = "Relight"
    bl_description = "Make the light of the scene's light grid anew, where geometry and spacing are as they were: lamps, sky, colours"

    def commands(self, context, exported):
        self.grid = settings.grid_path(context.scene)
        # beside it, so that it takes its place at once or not at all
        try:
            number, self.made = tempfile.mkstemp(".safetensors", f"{Path(self.grid).stem}.relit.", os.path.dirname(self.grid))
        except OSError as error:
            raise ToolError(f"{self.grid}: {error.strerror}") from error
        os.close(number)
        return [command.relight(context, exported, self.grid, self.made), command.probes(context, self.made)]

    def keep(self):
        os.replace(self.made, self.grid)

    def clean_up(self):
        if self.made is not None:
            remove(self.made)


class NLG_OT_check(ToolOperator):
    bl_idname = "nlg.check"
    bl_label = "Check"
    bl_description = "Say whether the scene's light grid is what a bake would make, or what has changed since"

    def commands(self, context, exported):
        return [command.check(context, exported, settings.grid_path(context.scene))]

    def finish(self, context, job):
        job.check(CHECK_FAILED)
        found = json.loads(job.output)["changes"] or ["fresh"]
        state.said += found
        self.report({"INFO" if job.exit_code == 0 else "WARNING"}, f"Light grid: {'; '.join(found)}")


class NLG_OT_view(ToolOperator):
    bl_idname = "nlg.view"
    bl_label = "View"
    bl_description = "Open a page in the browser to walk through the scene as its light grid lights it: the one that was made last, preview or not"

    def commands(self, context, exported):
        grid = state.shown or settings.grid_path(context.scene)
        self.page = os.path.join(exported.folder, "page")
        shutil.rmtree(self.page, ignore_errors=True)
        return [command.view(context, exported, grid, self.page)]

    def finish(self, context, job):
        job.check()
        page = Path(self.page, "index.html")
        self.report({"INFO"}, f"page: {page}")
        bpy.ops.wm.url_open(url=page.as_uri())


class NLG_OT_cancel(Operator):
    bl_idname = "nlg.cancel"
    bl_label = "Cancel"
    bl_description = "End the tool that is at work. Files stay as they were"

    @classmethod
    def poll(cls, context):
        return state.job is not None

    def execute(self, context):
        state.job.cancel()
        return {"FINISHED"}


CLASSES = (NLG_OT_bake, NLG_OT_preview, NLG_OT_relight, NLG_OT_check, NLG_OT_view, NLG_OT_cancel)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.app.handlers.load_post.append(forget)
    atexit.register(stop)


def unregister():
    atexit.unregister(stop)
    bpy.app.handlers.load_post.remove(forget)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
