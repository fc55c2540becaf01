"""Draws all frames of a run as a GIF or as a video: `poretwin plot RUN --animate FILE`.

A GIF needs the Debian package python3-pil, which python3-matplotlib depends on. An MP4 needs the program ffmpeg.
"""
import shutil
import subprocess

import numpy as np
import plot
import style
from stop import NO_FILE, WRONG_COMMAND, Stop
from style import plt

RATE = 10  # frames a second
MOST_FRAMES = 200  # 20 s; of runs with more frames, this number is selected evenly
PIXELS = 900  # along the longer side of the particles' picture
DPI = 110
RARE = 0.005  # fraction of the values that may lie outside the range of colours
KINDS = (".gif", ".mp4")


def chosen(count):
    """Indices of the steps that are shown: all, or MOST_FRAMES evenly chosen ones that include the first and the last."""
    return np.unique(np.linspace(0, count - 1, min(count, MOST_FRAMES)).round().astype(int)).tolist()


class Scene:
    """The main field of each phase, or the requested field, with one colour range and one section of the plane for all times."""

    def __init__(self, pictures):
        self.shown = []
        for frames, phase, name in pictures:
            shown = plot.Shown(frames, phase, name, chosen(frames.n_steps), PIXELS, RARE)
            if shown.steps:
                self.shown.append(shown)
        if not self.shown:
            raise Stop(NO_FILE, "no frame of this run has particles")
        self.times = sorted({shown.frames.times[step] for shown in self.shown for step in chosen(shown.frames.n_steps)})
        self.times = [self.times[k] for k in chosen(len(self.times))]
        widths = [plot.panel_width(shown.shape()) for shown in self.shown]
        heights = [width * shown.shape()[1] / shown.shape()[0] for width, shown in zip(widths, self.shown)]
        beside = len(self.shown) > 1 and sum(widths) + 2.8 < 1.5 * style.PAGE  # narrow bodies side by side
        size = (sum(widths) + 1.4 * len(widths), max(heights) + 0.9) if beside else (max(widths) + 1.4, sum(heights) + 0.85 * len(heights))
        grid = (1, len(self.shown)) if beside else (len(self.shown), 1)
        self.figure, panels = plt.subplots(*grid, squeeze=False, figsize=size, dpi=DPI, layout="compressed",
                                           **({"width_ratios": widths} if beside else {"height_ratios": heights}))
        self.panels = list(panels.flat)
        # Colour bars and labels are drawn before the first frame, so that the layout is the same in all frames.
        for shown, axes in zip(self.shown, self.panels):
            drawn = shown.paint(axes, shown.steps[-1])
            shown.axis_labels(axes)
            self.figure.colorbar(drawn, ax=axes, label=shown.label, aspect=20, pad=0.02, extend=shown.extend)
        self.figure.canvas.draw()
        self.figure.set_layout_engine("none")

    def picture(self, time):
        """Red, green, blue of each pixel [rows, columns, 3]; rows and columns are even numbers, as video formats require."""
        for shown, axes in zip(self.shown, self.panels):
            step = shown.frames.nearest(time)
            if step in shown.steps:
                shown.paint(axes, step)
            else:  # before the first water enters
                for artist in [*axes.images, *axes.collections, *axes.patches]:
                    artist.remove()
                axes.set_title(f"{style.BODY[shown.phase]}, t = {style.number(shown.frames.times[step])} s: none")
        self.figure.canvas.draw()
        pixels = np.asarray(self.figure.canvas.buffer_rgba())[:, :, :3]
        return np.ascontiguousarray(pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2])


def write_gif(path, pictures):
    try:
        from PIL import Image
    except ImportError:
        raise Stop(NO_FILE, "a GIF needs the package python3-pil") from None
    images = [Image.fromarray(picture) for picture in pictures]
    # One palette serves all frames, so that colours do not flicker. It is made from a few frames, placed side by side.
    some = [images[k] for k in np.unique(np.linspace(0, len(images) - 1, 8).round().astype(int))]
    strip = Image.new("RGB", (images[0].width, images[0].height * len(some)))
    for k, image in enumerate(some):
        strip.paste(image, (0, k * image.height))
    palette = strip.quantize(256, dither=Image.Dither.NONE)
    images = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    images[0].save(path, save_all=True, append_images=images[1:], duration=1000 // RATE, loop=0)


def write_mp4(path, pictures):
    height, width, _ = pictures[0].shape
    command = ["ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(RATE), "-i", "-",
               "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path)]
    done = subprocess.run(command, input=b"".join(picture.tobytes() for picture in pictures), stderr=subprocess.PIPE)
    if done.returncode != 0:
        raise SystemExit(f"{path}: ffmpeg failed: {done.stderr.decode(errors='replace').strip()}")


def draw(options):
    """Draws the animation of `--animate FILE`, with the options `--field` and `--phase`."""
    path = options.animate
    if path.suffix not in KINDS:
        raise Stop(WRONG_COMMAND, f"{path}: expected a name that ends in .gif or .mp4")
    for name in ("time", "gauge", "out"):
        if getattr(options, name):
            raise Stop(WRONG_COMMAND, f"--{name} does not go with --animate, which shows all frames in {path}")
    if path.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise Stop(NO_FILE, "an MP4 needs the program ffmpeg, of the package ffmpeg; or write a GIF")
    pictures = plot.requested_pictures(options.run, options)
    if not pictures:
        raise plot.nothing_to_draw(options.run, options)
    scene = Scene(pictures)
    path.parent.mkdir(parents=True, exist_ok=True)
    (write_gif if path.suffix == ".gif" else write_mp4)(path, [scene.picture(time) for time in scene.times])
    plt.close(scene.figure)
    print(path)
