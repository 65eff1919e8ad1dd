"""Images as arrays, and how far one is from another."""
import numpy as np

LUMINANCE = np.array([0.265, 0.670, 0.065])  # Radiance's


def load(path):
    """An EXR or .npy file as an array of height x width x 3, f64."""
    if path.endswith('.npy'):
        return np.load(path).astype(np.float64)
    import mitsuba as mi
    if mi.variant() is None:
        mi.set_variant('scalar_rgb')
    bitmap = mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap, np.float64)


def smooth(reference, edge=0.15):
    """The pixels whose 3 x 3 neighbourhood in the reference varies by less than `edge` and holds no lamp.

    Elsewhere silhouettes and lamps decide by the position of a sample within its pixel, not by light.
    """
    y = reference @ LUMINANCE
    padded = np.pad(y, 1, mode='edge')
    h, w = y.shape
    shifted = np.stack([padded[i:i + h, j:j + w] for i in range(3) for j in range(3)])
    high, low = shifted.max(0), shifted.min(0)
    mask = (high - low) < edge * np.maximum(high, 0.01 * y.mean())
    return mask & (high < 10 * y.mean())


def error(reference, image, mask):
    """(relative RMSE, mean of image / mean of reference) over the pixels of a mask."""
    r, i = reference[mask], image[mask]
    return float(np.sqrt(((i - r) ** 2).mean()) / r.mean()), float(i.mean() / r.mean())
