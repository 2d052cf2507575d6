"""The similarity between two sets of points, for the scripts beside this one."""
import numpy as np


def similarity(a, b):
    """scale, R, t of b = scale R a + t (Umeyama 1991); a, b: n x 3."""
    ma, mb = a.mean(0), b.mean(0)
    U, S, V = np.linalg.svd((b - mb).T @ (a - ma) / len(a))
    D = np.diag([1, 1, np.sign(np.linalg.det(U) * np.linalg.det(V))])
    R = U @ D @ V
    scale = np.trace(np.diag(S) @ D) / np.mean(np.sum((a - ma) ** 2, 1))
    return scale, R, mb - scale * R @ ma
