"""What a program writes on a terminal of a size."""
import fcntl
import os
import pty
import re
import struct
import subprocess
import termios


def on_terminal(words, columns, rows, folder, environment):
    """The exit code and what stands there, with its control codes; lines end with \\n."""
    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    child = subprocess.Popen(words, stdin=follower, stdout=follower, stderr=follower, cwd=folder, env=environment)
    os.close(follower)
    text = b""
    while True:
        try:
            piece = os.read(leader, 65536)
        except OSError:
            break
        if not piece:
            break
        text += piece
    os.close(leader)
    return child.wait(), text.decode(errors="replace").replace("\r\n", "\n")


def plain(text):
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


def result_of(text):
    """The lines after those of the run: what a pipeline ends with."""
    return re.split(r"(?m)^  \S+run\.jsonl\n", plain(text))[-1].splitlines()


def too_large(lines, columns, rows):
    """What of a result does not fit the screen: a sentence, or nothing. A word that is longer than a line may be (a path)."""
    wide = [line for line in lines if len(line) > columns and len(line.split()) > 1]
    if wide:
        return f"{len(wide[0])} columns of {columns}: {wide[0]}"
    taken = sum(max(1, -(-len(line) // columns)) for line in lines)
    return f"{taken} rows of {rows}, one of them the next prompt's" if taken >= rows else ""
